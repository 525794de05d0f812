"""Functions of genus two that the Kovalevskaya top alone needs."""
