"""What runs tell: a report of one as a page and in words, and the record of a product."""
