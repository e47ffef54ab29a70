"""Find the files of a project, and check each of them."""
