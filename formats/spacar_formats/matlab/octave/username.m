function name = username()
% USERNAME  For scripts that set the variable `username` on Windows and macOS only and read it on Linux too.
  name = getenv('USER');
end
