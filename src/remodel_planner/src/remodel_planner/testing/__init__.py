"""Problems to test and measure planners with."""
