"""What is there because a paper has it, one package a document; only the table of methods knows of it."""
