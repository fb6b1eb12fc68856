"""Reading: what the store answers, and the rows it answers from."""
