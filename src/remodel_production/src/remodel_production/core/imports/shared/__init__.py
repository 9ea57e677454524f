"""What the formats of designs share: texts, units, guesses, and the account of an import."""
