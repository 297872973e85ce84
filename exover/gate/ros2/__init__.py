"""The gate for ROS 2: actions and services in the wire format of rmw_cyclonedds_cpp."""
