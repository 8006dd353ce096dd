"""The studio: a page on this machine, and the server behind it; a job is a command."""
