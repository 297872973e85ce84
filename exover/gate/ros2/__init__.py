"""The gate in front of ROS 2: actions and services on the wire that rmw_cyclonedds speaks."""
