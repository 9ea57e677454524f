"""Pure planning: values in, values out."""
