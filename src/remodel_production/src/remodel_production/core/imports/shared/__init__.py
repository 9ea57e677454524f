"""What the formats of designs share: texts, units, assumptions, and the account of an import."""
