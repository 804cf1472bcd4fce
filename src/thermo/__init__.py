"""ThermoField."""
