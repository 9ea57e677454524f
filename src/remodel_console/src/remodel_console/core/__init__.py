"""What commands mean, and what they do to the chart that is edited."""
