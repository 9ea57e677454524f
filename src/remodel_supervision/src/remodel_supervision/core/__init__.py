"""Pure supervision: values in, values out."""
