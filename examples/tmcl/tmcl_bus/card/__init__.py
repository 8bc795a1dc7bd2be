"""Cards that make axes TMCL modules: ``module_ear.py`` finds requests in what a station hears,
``tmcl_module.py`` is the station, ``interpreter.py`` carries requests out, ``module_axis.py`` moves the axis.
"""
