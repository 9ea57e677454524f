"""Commands about the skills."""
