function now_ = datetime(varargin)
% DATETIME  For Octave 7, which has none: the serial number of now, which DATESTR takes. Any argument is refused.
  if nargin > 0 && ~(nargin == 1 && strcmp(varargin{1}, 'now'))
    error('Octave:undefined-function', 'datetime: only the present time is provided for Octave');
  end
  now_ = now();
end
