"""The heavy top as a dynamical system: levels of energy and area, and what lies on them."""
