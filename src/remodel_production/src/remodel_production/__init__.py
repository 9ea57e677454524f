"""Production knowledge: designs, the boards they are built on, and the database of orders."""
