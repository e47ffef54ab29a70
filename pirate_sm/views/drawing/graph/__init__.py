"""The neutral graph of a drawing, made from missions and charts."""
