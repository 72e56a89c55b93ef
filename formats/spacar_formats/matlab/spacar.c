/* spacar(mode, file) as a MEX file, because callers ask for exist('spacar', 'file') == 3.

   Build: spacar matlab --build FOLDER (a shell), or spacar_build(FOLDER) (MATLAB, Octave).
   The work is in spacar_engine.m, which spacar.m calls too; here the error that it reports is thrown. */
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

void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[])
{
    mxArray *input[2], *answer[2];

    if (nrhs < 2 || nrhs > 3)
        refuse("SPACAR requires 2 or 3 input arguments");
    if (nrhs == 3 && !mxIsEmpty(prhs[2]))
        refuse("the third argument CCONST is not supported");
    if (nlhs > 1)
        refuse("SPACAR has one output argument, the status 0");
    input[0] = (mxArray *) prhs[0];
    input[1] = (mxArray *) prhs[1];
    mexCallMATLAB(2, answer, 2, input, "spacar_engine");
    if (!mxIsEmpty(answer[0]))
        fail(answer[1], answer[0]);
    if (nlhs == 1)
        plhs[0] = mxCreateDoubleScalar(0.0);
}
