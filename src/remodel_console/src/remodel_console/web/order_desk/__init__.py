"""The page of the order desk."""
