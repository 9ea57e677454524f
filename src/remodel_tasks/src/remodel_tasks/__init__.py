"""Planning: use cases, orders as problems, the search for plans, and charts of tasks."""
