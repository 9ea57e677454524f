"""What the cell believes about its panel from its own actions and observations."""
