"""The files of a model: URDF, TOML and CSV, read, checked and written."""
