"""Names and one-line helps of all commands: what `spacar --help` prints without importing anything.

The command NAME is `spacar_cli.commands.NAME:command`, or one of `commands.stored_results`, imported when it is called;
the modes have their own table, `spacar.modes.MODES`.
"""

COMMANDS = {
    "help": "options of a mode or a command, or the page of a topic",
    "check": "read an input file and report, without running it",
    "edit": "write an input file and see it, in a browser",
    "keywords": "the keywords of the input language",
    "examples": "list or copy the example models",
    "sweep": "parameter study: many values, one row of quantities each",
    "sensitivity": "exact derivatives of stationary quantities by numbers of the file",
    "trade": "speed against accuracy of a model, and the cheapest setting",
    "draw": "picture or animation of the mechanism at chosen steps (also: spadraw)",
    "visual": "vibration and buckling modes, constraints, stresses as pictures (also: spavisual)",
    "plot": "time histories of results, or one quantity against another",
    "view": "a page that turns, zooms and plays a result in a browser",
    "report": "one self-contained HTML page about a run",
    "checksbf": "what is in a result file, and whether it is sound",
    "getfrsbf": "print a variable of a result file",
    "repinsbf": "replace the value of a variable",
    "loadsbd": "export a .sbd result to .npz, .mat or .csv",
    "loadsbm": "export a .sbm result to .npz, .mat or .csv",
    "combsbd": "join .sbd results of the same mechanism",
    "eigen": "frequencies, root locus, Campbell diagram of a result",
    "bode": "Bode diagram of a .ltv result",
    "stress": "stress resultants and stresses along beams as numbers",
    "compliance": "compliance matrix of a node",
    "flexure": "a flexure over its range of motion: stiffness, errors, frequencies ...",
    "getss": "state space matrices of one step of a .ltv result",
    "sim": "controlled simulation from a model file (also: spasim)",
    "fmu": "the mechanism as a functional mock-up unit for other simulators",
    "ltv": "response of a time-varying linear system (.ltv)",
    "mrltv": "modal reduction of a .ltv system",
    "spacntrl": "fold feedback into a .ltv system",
    "matlab": "the folder with the files for MATLAB and Octave",
    "symbolic": "equations of motion of a model file by computer algebra",
    "completion": "completion of the command line by the TAB key, for bash, zsh, fish",
}
OF_RESULT_FILES = ("checksbf", "getfrsbf", "repinsbf", "loadsbd", "loadsbm", "combsbd", "getss")
OF_THE_MANUAL = {"spadraw": "draw", "spavisual": "visual", "spasim": "sim"}  # names in SPACAR's manual

TOPICS = {  # word of `spacar help` -> page of docs/, which wheels have in spacar_cli/pages
    "convergence": "convergence.md",
    "expressions": "expressions.md",
    "flexures": "flexures.md",
    "sensitivities": "sensitivity.md",
    "simulation": "simulation.md",
    "studies": "studies.md",
}
