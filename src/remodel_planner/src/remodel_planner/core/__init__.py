"""What commands tell: values in, values out."""
