"""Contact with friction between strands: the rule `contact` of the solver `rod`."""
