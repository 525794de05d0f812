"""The attitude of the Kovalevskaya top."""
