"""Operations of ``rtconf`` on configuration sets, files of them, and manager properties."""
