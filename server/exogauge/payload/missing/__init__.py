"""What the wrench of a payload lacks beside a rigid body behind an ideal sensor: sought, judged, named or refused."""
