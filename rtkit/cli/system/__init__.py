"""What the commands have in common that bring systems up from profiles, run and end them."""
