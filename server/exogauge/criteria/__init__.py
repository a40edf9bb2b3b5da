"""Numbers that decide a name, a verdict, a doubt or a warning, with
its unit, its reason and its source."""
