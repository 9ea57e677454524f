"""Cable trees: values in, values out.

problem    what is to be ordered; dzn reads it from MiniZinc data
order      what an order violates and costs: the checker, and the plain reference of the kernel
rounds     how much the search does at which temperature, for a limit of time
"""
