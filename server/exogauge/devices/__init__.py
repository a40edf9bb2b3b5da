"""The wear: bands as wires through via points, what they pull with, and what they do to the joints."""
