"""`spacar checksbf FILE`."""

import json

from spacar.errors import AnalysisError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment


@words.command("checksbf")
@words.option("as_json", ": the findings")
def command(environment: Environment, file: str, as_json: bool) -> None:
    """List the variables of a result file and verify its checksums; exit status 1 when it is damaged."""
    from spacar_formats import checksbf
    from spacar_formats.sbf import SbfError

    try:
        check = checksbf.checksbf(file)
    except SbfError as error:  # the file is what was asked about, so this is a result and no wrong use
        raise AnalysisError(str(error), error.code) from None
    if as_json:
        environment.say(json.dumps(checksbf.as_json(check)))
    else:
        environment.say(*checksbf.listing(check))
    if not check.sound:
        raise AnalysisError(f"{check.path} is damaged: {'; '.join(check.damage)}", "files.damaged")
