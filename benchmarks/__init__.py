"""Side-by-side speed; each file prints 'name: value unit'."""
