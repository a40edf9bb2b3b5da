"""Planning: postures and motion that tell most of a payload, within what the robot and its cell allow."""
