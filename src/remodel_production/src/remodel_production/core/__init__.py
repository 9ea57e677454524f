"""Pure knowledge: orders, catalogues, designs and boards; values in, values out."""
