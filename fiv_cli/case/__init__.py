"""The case file: TOML text in, a clean and complete `Case` out."""
