"""What ``rtconf`` does with configuration sets, files of them, and properties of managers."""
