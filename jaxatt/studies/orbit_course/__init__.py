"""What an orbit brings over time: ground track, eclipses, sun and magnetic field."""
