/* spacar(mode, file) as a MEX file, because callers ask for exist('spacar', 'file') == 3.

   Build: spacar matlab --build FOLDER (a shell), or spacar_build(FOLDER) (MATLAB, Octave).
   The work is in spacar_engine.m, which spacar.m calls too; here the error that it reports is thrown, and the arrays of the
   run, which spacar_results.m reads, go to the output argument or, typed at the prompt or in a script, to the workspace. */
#include "mex.h"

/* By the function `error`: mexErrMsgIdAndTxt of Octave puts the name of the MEX file before the message, which callers
   compare as a whole. */
static void fail(mxArray *identifier, mxArray *message)
{
    mxArray *input[3];

    input[0] = identifier;
    input[1] = mxCreateString("%s");
    input[2] = message;
    mexCallMATLAB(0, NULL, 3, input, "error");
}

static void refuse(const char *message)
{
    fail(mxCreateString("spacar:arguments"), mxCreateString(message));
}

/* Whether the caller is the prompt, or a script that runs there: it sees a variable that was put there. */
static int is_typed(void)
{
    static const char marker[] = "spacar_is_called_from_here";
    mxArray *seen, *input[2];

    if (mexPutVariable("base", marker, mxCreateDoubleScalar(1.0)))
        return 0;
    seen = mexGetVariable("caller", marker);
    input[0] = mxCreateString("base");
    input[1] = mxCreateString("clear spacar_is_called_from_here");
    mexCallMATLAB(0, NULL, 2, input, "evalin");
    return seen != NULL;
}

static void to_workspace(const mxArray *data)
{
    int k, failed = 0;

    for (k = 0; k < mxGetNumberOfFields(data); k++)
        failed |= mexPutVariable("base", mxGetFieldNameByNumber(data, k), mxGetFieldByNumber(data, 0, k));
    if (failed)
        mexWarnMsgIdAndTxt("spacar:workspace",
                           "variables cannot be added to this workspace: write result = spacar(mode, file)");
}

void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[])
{
    mxArray *input[2], *answer[2];

    if (nrhs < 2 || nrhs > 3)
        refuse("SPACAR requires 2 or 3 input arguments");
    if (nrhs == 3 && !mxIsEmpty(prhs[2]))
        refuse("the third argument CCONST is not supported");
    if (nlhs > 1)
        refuse("SPACAR has one output argument, a structure");
    input[0] = (mxArray *) prhs[0];
    input[1] = (mxArray *) prhs[1];
    mexCallMATLAB(2, answer, 2, input, "spacar_engine");
    if (!mxIsEmpty(answer[0]))
        fail(answer[1], answer[0]);
    if (nlhs == 0 && !is_typed())
        return;
    mexCallMATLAB(1, answer, 2, input, "spacar_results");
    if (nlhs == 1)
        plhs[0] = answer[0];
    else
        to_workspace(answer[0]);
}
