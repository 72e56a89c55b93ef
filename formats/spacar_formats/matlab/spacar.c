/* spacar(mode, file) as a MEX file, because callers ask for exist('spacar', 'file') == 3.

   Build: spacar matlab --build FOLDER (a shell), or spacar_build(FOLDER) (MATLAB, Octave).
   The work is in spacar_engine.m, which spacar.m calls too; here an error that it reports is thrown. */
#include "mex.h"

void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[])
{
    mxArray *input[2], *answer[2];
    char *message, *identifier;

    if (nrhs < 2 || nrhs > 3)
        mexErrMsgIdAndTxt("spacar:arguments", "SPACAR requires 2 or 3 input arguments");
    if (nrhs == 3 && !mxIsEmpty(prhs[2]))
        mexErrMsgIdAndTxt("spacar:arguments", "the third argument CCONST is not supported");
    if (nlhs > 1)
        mexErrMsgIdAndTxt("spacar:arguments", "SPACAR has one output argument, the status 0");
    input[0] = (mxArray *) prhs[0];
    input[1] = (mxArray *) prhs[1];
    mexCallMATLAB(2, answer, 2, input, "spacar_engine");
    message = mxArrayToString(answer[0]);
    identifier = mxArrayToString(answer[1]);
    if (message == NULL || identifier == NULL)
        mexErrMsgIdAndTxt("spacar:internal", "spacar_engine did not return two texts");
    if (message[0] != '\0')
        mexErrMsgIdAndTxt(identifier, "%s", message);
    mxFree(message);
    mxFree(identifier);
    if (nlhs == 1)
        plhs[0] = mxCreateDoubleScalar(0.0);
}
