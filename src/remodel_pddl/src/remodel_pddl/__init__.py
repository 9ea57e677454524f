"""Problems and plans in the languages of other planners: PDDL, HDDL, PlanBench."""
