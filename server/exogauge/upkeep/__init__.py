"""What keeps an installation whole while it runs, and carries it elsewhere."""
