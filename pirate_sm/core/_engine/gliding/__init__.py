"""Let frames pass that change nothing but signals: what must stay true, and the state then."""
