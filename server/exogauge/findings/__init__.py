"""What was found, as data: findings, what is left, what cannot be told, what to do next."""
