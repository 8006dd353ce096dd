"""What is done with maps beyond growing one: healing, extending, repairing, advection, inspection."""
