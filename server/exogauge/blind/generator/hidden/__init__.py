"""What can be hidden in a case. Formulas differ on purpose from those that textbooks, and searches, begin with."""
