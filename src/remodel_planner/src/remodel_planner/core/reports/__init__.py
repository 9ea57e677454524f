"""Reports: of a run, as a page and as text, and of a product."""
