"""The Kovalevskaya top: A = B = 2C, the centre of mass in the equator."""
