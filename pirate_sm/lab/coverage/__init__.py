"""Which branches of missions were ever taken, and by what kind of run; rehearsals of the others."""
