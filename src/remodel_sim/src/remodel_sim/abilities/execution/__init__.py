"""What an ability may use of its robot and cell, and how its steps run."""
