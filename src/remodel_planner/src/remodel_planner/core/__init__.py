"""What commands print: values in, values out."""
