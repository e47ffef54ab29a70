"""The language server: what people see of a file in their editor, while they type."""
