"""What people look at: tables and plots. Import the module you need; each brings its library."""
