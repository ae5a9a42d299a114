"""What ``rtdoctor`` looks at: this installation, this user's folders, limits, managers."""
