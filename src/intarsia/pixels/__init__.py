"""Growth pixel by pixel: neighbourhoods, scanning in rows, and growing outward."""
